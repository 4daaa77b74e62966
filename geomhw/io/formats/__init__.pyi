from .obj_read import read_obj as read_obj
from .off_read import read_off as read_off
from .ply_read import read_ply as read_ply
from .stl_read import read_stl as read_stl
from .vtk_read import read_vtk as read_vtk
from .vtk_xml_read import read_vtp as read_vtp
from .vtk_xml_read import read_vtp_cloud as read_vtp_cloud
from .vtk_xml_read import read_vtu as read_vtu
