#include "lum/net/sensor.h"
int main(void)
{
    return 0;
}
