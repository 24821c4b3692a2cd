"""Figures of lesson 03."""
