"""The blind check: cases with sealed keys, diagnosed from their recordings alone, then opened and scored."""
