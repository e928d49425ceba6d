"""Published figures made anew from the muscles' sizes, their claims checked beside them."""

from .claims import Claim as Claim
from .reproduced import Record as Record
