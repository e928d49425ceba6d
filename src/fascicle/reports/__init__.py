"""Self-contained HTML pages: one file, opens offline, prints well."""

from .page import Page as Page
from .page import data_uri as data_uri
from .page import prose as prose
from .page import quotation as quotation
from .page import verdict as verdict
