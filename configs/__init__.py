"""Presets: settings for kinds of clips, as commented YAML. Packed into the wheel as `footfix.configs`."""
