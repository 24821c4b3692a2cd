"""The computers of a class: whether one is fit, how work moves to another, how thirty are installed."""
