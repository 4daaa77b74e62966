from .arrays import compare_arrays as compare_arrays
from .arrays import compare_named as compare_named
from .files import compare_files as compare_files
from .findings import Comparison as Comparison
from .findings import Finding as Finding
from .rules import Ignored as Ignored
from .rules import Tolerance as Tolerance
