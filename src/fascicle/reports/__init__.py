"""Self-contained HTML pages: one file, opens offline, prints well."""

from ..core.lazy import lazily
from .page import Page as Page
from .page import data_uri as data_uri
from .page import prose as prose
from .page import quotation as quotation
from .page import verdict as verdict


__getattr__, __dir__ = lazily(__name__, {}, {"fitted": "calibrate.after.pictures"})
