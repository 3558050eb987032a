"""The reference of the site: pages that are made of the code, and READMEs held to it."""
