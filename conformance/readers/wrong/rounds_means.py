#!/usr/bin/python3 -IS
# caught by: valid
"""Computes means in single precision."""
import sys
from array import array

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.mean
t4d_reader.mean = lambda sources: tuple(array("f", right(sources)))

sys.exit(t4d_reader.main(sys.argv[1:]))
