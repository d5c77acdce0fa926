#!/usr/bin/python3 -IS
# caught by: valid
"""Takes t > T at the last time, too, where nothing is above."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.cut
t4d_reader.cut = lambda slabs, plane, at_last: right(slabs, plane, False)

sys.exit(t4d_reader.main(sys.argv[1:]))
