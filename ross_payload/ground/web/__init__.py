"""The page that a ground station opens in a browser: aiohttp in front of what is known of the payloads."""
