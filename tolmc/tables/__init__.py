"""Tables and sentences for people, built once: what they say is settled here, how it looks by terminal and report."""
