"""Names in messages, which rospy does not give as they were sent."""

_NO_UTF8 = "\ufffd"


def sent_name_fault(name: str) -> str:
    """Why a name in a message cannot be used, in words; "" if it can.

    rospy puts U+FFFD in the place of what is no UTF-8, so that two names may become one.
    """
    if _NO_UTF8 not in name:
        return ""
    return "the name %r is no UTF-8 (U+FFFD stands for what is not): send it as UTF-8" % name[:80]
