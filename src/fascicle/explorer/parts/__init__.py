"""What the tabs and the page are made of: fields, figures, notes, links, downloads."""
