"""Every layout that ships, as tests walk through them."""

from fairlead.layout import load_layout
from fairlead.plugins import LAYOUTS as REGISTERED

LAYOUTS = {name: load_layout(name) for name in REGISTERED.names()}
LAYOUT_DIMS = {name: one.dim for name, one in LAYOUTS.items() if one.dim is not None}
