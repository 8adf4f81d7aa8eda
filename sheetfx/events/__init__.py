"""What a step brings to light: critical points, events of one's own, ends of paths."""
