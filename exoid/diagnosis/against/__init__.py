"""Before against after: what differs between two sets of recordings, asked with the evidence of a diagnosis."""
