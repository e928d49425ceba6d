"""Text can be read on the colors that it stands on, and every face has the theme's."""

import pytest

from fascicle.plot import theme


def contrast(first: str, second: str) -> float:
    """Contrast ratio of two colors [-], from 1 to 21."""

    def luminance(color: str) -> float:
        channels = [channel / 255 for channel in theme.red_green_blue(color)]
        red, green, blue = (
            x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in channels
        )
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    low, high = sorted((luminance(first), luminance(second)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("colors", [theme.LIGHT, theme.DARK], ids=["light", "dark"])
def test_text_can_be_read_on_what_it_stands_on(colors):
    # WCAG 2.2, 1.4.3: 4.5 for text; 1.4.11: 3 for what can be used
    for name in ("ink", "soft", "accent", "good", "odd", "bad"):
        for ground in (colors.paper, colors.raised):
            assert contrast(getattr(colors, name), ground) >= 4.5, (name, ground)
    assert contrast(colors.bad, colors.alarm) >= 4.5
    assert contrast(theme.WHITE, colors.deep) >= 4.5
    assert contrast(colors.edge, colors.paper) >= 3
    assert contrast(colors.fiber, colors.tube) >= 3


def test_every_face_has_the_theme():
    from fascicle.explorer.widgets import DARK, LIGHT, page_css
    from fascicle.report.page import render

    assert set(theme.CYCLE) <= set(theme.LIGHT.curves)
    assert (LIGHT, DARK) == (theme.LIGHT, theme.DARK)
    report = render("page.html", title="A page")
    for name, value in theme.css_variables(theme.LIGHT).items():
        assert f"{name}: {value};" in report
        assert f"{name}: {value};" in page_css(LIGHT)
