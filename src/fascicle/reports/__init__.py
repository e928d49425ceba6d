"""Self-contained HTML pages: one file, opens offline, prints well."""

from ..core.lazy import attach_lazy
from .page import data_uri as data_uri
from .page import prose as prose
from .page import render as render
from .page import verdict as verdict


__getattr__, __dir__ = attach_lazy(__name__, {})
