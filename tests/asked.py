"""What the reader of records asks for."""

import pytest

from fascicle.records import MissingMetadataError, load, loads


def asked(file, **options):
    """Argument, key and value of each choice that the refusal of a text or path offers."""
    read = loads if isinstance(file, str) and "\n" in file else load
    with pytest.raises(MissingMetadataError) as error:
        read(file, **options)
    return [choice[:3] for choice in error.value.choices]
