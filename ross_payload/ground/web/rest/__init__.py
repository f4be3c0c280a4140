"""The page's REST interface: programs see and order what browsers do, by the same rules, described by OpenAPI."""
