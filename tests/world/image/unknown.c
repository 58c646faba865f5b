/* A tool with a call that the world does not have, and one with data that would
 * be shared by all of its processes: no image is made of them. */
#ifdef UNKNOWN_CALL
#include <unistd.h>

int main(void)
{
    return (int)getuid();
}
#else
__thread int calls;

int main(void)
{
    return ++calls;
}
#endif
