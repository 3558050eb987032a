"""The site: the pages below docs/, with what is made of the code and of tutorials, as HTML."""
