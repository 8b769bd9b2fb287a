"""Tests of apps, and of the whole product."""
