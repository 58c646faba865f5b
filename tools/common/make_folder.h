/* A new folder. */
#ifndef LUM_TOOLS_MAKE_FOLDER_H
#define LUM_TOOLS_MAKE_FOLDER_H

/* 0, or -1 with the reason in errno; EEXIST: something has this name. */
int make_folder(const char *path);

/* The same for its user alone, where the system has such rights. */
int make_private_folder(const char *path);

/* Remove it if it is empty. */
void remove_folder(const char *path);

#endif
