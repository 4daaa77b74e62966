"""Kinds of files that commands draw; the program knows them before it loads a command."""

#: Kinds of files that hold one picture.
KINDS = ("png", "svg", "pdf")
#: Kinds of films.
FILMS = ("gif", "mp4")
