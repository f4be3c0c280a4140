"""MAVLink: values of the wire, and bytes to values and back."""
