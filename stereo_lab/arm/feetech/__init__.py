"""Bus servos behind the same arm: ``feetech://PORT``."""
