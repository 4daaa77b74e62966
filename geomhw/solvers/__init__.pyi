from .auto import LaplaceSolver as LaplaceSolver
from .direct import DirectSolver as DirectSolver
from .expm import expm as expm
from .expm import taylor3 as taylor3
from .multigrid import MultigridSolver as MultigridSolver
