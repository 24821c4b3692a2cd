"""What judges the chain: both ways measured on a recording, the report of it, and what each way costs."""
