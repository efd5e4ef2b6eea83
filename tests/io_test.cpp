int x_io;
