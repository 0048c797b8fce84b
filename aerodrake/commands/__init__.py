"""The commands, each a page: its arguments, and what it does with them.

Drake and torch take seconds to import: each command imports what it needs.
"""
