"""What two files of one kind differ in: meshes, time series, tables, JSON documents, matrices, pictures.

``compare_files`` takes two paths. ``compare_arrays`` and ``compare_named`` take what is in memory already.
"""

from geomhw.compare.arrays import compare_arrays, compare_named
from geomhw.compare.files import compare_files
from geomhw.compare.findings import Comparison, Finding
from geomhw.compare.rules import Ignored, Tolerance

__all__ = ["Comparison", "Finding", "Ignored", "Tolerance", "compare_arrays", "compare_files", "compare_named"]
