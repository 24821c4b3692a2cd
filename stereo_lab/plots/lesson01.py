"""Figures of lesson 01."""
