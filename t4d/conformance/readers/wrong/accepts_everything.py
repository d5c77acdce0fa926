#!/usr/bin/python3 -IS
# caught by: invalid
"""Reads nothing and finds nothing wrong."""
print("{}")
