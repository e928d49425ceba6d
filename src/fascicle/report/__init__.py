"""Self-contained HTML pages: one file, opens offline, prints well."""

from .page import data_uri as data_uri
from .page import prose as prose
from .page import render as render
from .page import verdict as verdict
