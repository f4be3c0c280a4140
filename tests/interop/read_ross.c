/* Reads MAVLink from standard input and tells what our messages say; then asks for a turn on standard output. */
#include <stdio.h>
#include "ross/mavlink.h"

static void tell(const mavlink_message_t *message)
{
    if (message->msgid == MAVLINK_MSG_ID_ROSS_STATUS) {
        mavlink_ross_status_t status;
        mavlink_msg_ross_status_decode(message, &status);
        fprintf(stderr, "%u-%u state %u heading %.4f k %u\n", message->sysid, message->compid, status.state,
                (double)status.heading, status.k);
    } else if (message->msgid == MAVLINK_MSG_ID_ROSS_ALIGNMENT) {
        mavlink_ross_alignment_t alignment;
        mavlink_msg_ross_alignment_decode(message, &alignment);
        fprintf(stderr, "candidate %u rule %u gain %.1f\n", alignment.candidate, alignment.rule, (double)alignment.gain);
    }
}

static void turn(float degrees)
{
    mavlink_message_t message;
    uint8_t frame[MAVLINK_MAX_PACKET_LEN];
    mavlink_msg_command_long_pack(255, 190, &message, 1, 191, MAV_CMD_ROSS_TURN, 0, degrees, 0, 0, 0, 0, 0, 0);
    fwrite(frame, 1, mavlink_msg_to_send_buffer(frame, &message), stdout);
}

int main(void)
{
    mavlink_message_t message;
    mavlink_status_t status;
    for (int byte = getchar(); byte != EOF; byte = getchar())
        if (mavlink_parse_char(MAVLINK_COMM_0, (uint8_t)byte, &message, &status))
            tell(&message);
    turn(30.0f);
    return 0;
}
