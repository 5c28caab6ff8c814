"""What an editor asks of a text that is being written: functions of the text and a place in it, of no protocol."""
