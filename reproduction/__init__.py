"""Published figures made anew from the muscles' sizes, their claims checked beside them."""
