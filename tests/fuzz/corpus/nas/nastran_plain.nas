$ Nastran file written by meshio v5.3.5
BEGIN BULK
GRID*   1                                          0.E+0           0.E+0
*                  0.E+0
GRID*   2                                          1.E+0           0.E+0
*                  0.E+0
GRID*   3                                          1.E+0           1.E+0
*                  0.E+0
GRID*   4                                          0.E+0           1.E+0
*                  5.E-1
CTRIA3  1               1       2       3       
CTRIA3  2               1       3       4       
ENDDATA
