#!/usr/bin/python3 -IS
# caught by: valid/layer-as-far-back-as-can-be
"""Looks 16 parts back, however many bodies there are (S12)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("end - 16 * len(bodies)",
                      "end - 16"))

sys.exit(reader.main(sys.argv[1:]))
