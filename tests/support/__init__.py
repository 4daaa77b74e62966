"""What several tests share: meshes, exact solutions, files, ways to run the program."""
