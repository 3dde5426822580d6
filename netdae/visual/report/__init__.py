"""The report of `netdae verify` as one HTML file."""
