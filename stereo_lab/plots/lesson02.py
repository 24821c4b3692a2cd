"""Figures of lesson 02."""
