"""Whom one hears: recordings and synthetic voices."""
