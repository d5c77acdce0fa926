"""The classes of inputs of tools/fuzz/attack, by topic.

Importing a topic registers its classes in attack.CLASSES.
"""

from . import meshes, volumes, t4d_files, motions, questions, folders, programs
from .attack import CLASSES, Attack, Result, Run
