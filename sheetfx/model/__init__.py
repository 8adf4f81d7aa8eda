"""The model: parts, joints, supports, loads and contacts as plain data that own their weak forms."""
