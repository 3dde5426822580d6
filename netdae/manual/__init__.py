"""The manual: Markdown pages beside this file, which `netdae manual` lists and prints.

A page begins with its title and, as its second paragraph, one sentence that says what it holds.
"""
