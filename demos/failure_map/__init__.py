"""Methods of path following against structures on which some fail: `sheetfx map` in a checkout."""
