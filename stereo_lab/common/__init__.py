"""What every room stands on: files written whole or not at all, one thread where sums must agree, a printed table."""
