"""What is known of payloads, from their telemetry alone: frozen values, and the JSON picture that everybody draws."""
