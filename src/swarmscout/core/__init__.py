"""The ground floor: grid geometry, random streams, errors, the recorder's protocol."""
