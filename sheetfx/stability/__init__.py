"""Critical points and what follows from them: branches, snaps, buckling, vibrations, imperfections."""
