"""Curves, pictures and reports."""
