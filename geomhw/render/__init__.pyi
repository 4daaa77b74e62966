from .curve_pictures import curve_picture as curve_picture
from .flow_pictures import contact_sheet as contact_sheet
from .flow_pictures import flow_film as flow_film
from .interactive import show_window as show_window
from .page import page as page
from .pictures import geodesic_picture as geodesic_picture
from .pictures import helmholtz_picture as helmholtz_picture
from .vector_pictures import transport_picture as transport_picture
