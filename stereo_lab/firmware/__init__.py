"""The sketch of the real arm, its protocol, and how to build it."""
