"""From a study file (TOML) to a validated study."""
