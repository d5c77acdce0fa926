#!/usr/bin/python3 -IS
# caught by: valid/types-of-optional-chunks
"""Judges by the last character of a type whether it has small letters."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("[A-Z][A-Z0-9]{3}|[a-z][A-Za-z0-9]{3}",
                      "[A-Z][A-Z0-9]{3}|[a-z][A-Za-z0-9]{2}[a-z]"))

sys.exit(reader.main(sys.argv[1:]))
