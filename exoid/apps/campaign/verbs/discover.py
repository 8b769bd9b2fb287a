"""`exoid discover` in a campaign: the effects that are missing."""

from exoid.apps.campaign.verb import CampaignVerb

VERB = CampaignVerb()
